//! Bytes on a line that are not our packets: a wrong baud rate, or a different device.

/// Number of bytes without a packet that call for a remark: at least twice the longest packet.
const BYTES_MIN: u64 = 1024;

/// Number of bytes in whole lines of text that call for a remark: packets do not look like text.
const TEXT_BYTES_MIN: u64 = 128;

/// Minimum fraction of printable bytes in text.
const TEXT_MIN: f64 = 0.9;

/// Maximum length of the line quoted as an example, characters.
const EXAMPLE_MAX: usize = 40;

/// Bytes that have arrived before the first packet.
#[derive(Debug, Default)]
pub struct Strangers {
    bytes: u64,
    printable: u64,
    line: String,
    /// The latest whole line.
    example: String,
}

impl Strangers {
    pub fn take(&mut self, bytes: &[u8]) {
        self.bytes += bytes.len() as u64;
        for byte in bytes {
            let is_end = matches!(byte, b'\r' | b'\n');
            let is_text = is_end || matches!(byte, b' '..=b'~' | b'\t');
            self.printable += u64::from(is_text);
            if is_end && !self.line.is_empty() {
                self.example = std::mem::take(&mut self.line);
            } else if is_text && !is_end && self.line.len() < EXAMPLE_MAX {
                self.line.push(char::from(*byte));
            }
        }
    }

    /// Describes what the bytes most likely are, and what to do; `None` before there are enough of
    /// them.
    pub fn what(&self) -> Option<String> {
        let Self {
            bytes, printable, ..
        } = *self;
        let is_text = printable as f64 >= TEXT_MIN * bytes as f64 && !self.example.is_empty();
        let min = if is_text { TEXT_BYTES_MIN } else { BYTES_MIN };
        if bytes < min {
            return None;
        }
        Some(match is_text {
            true => format!(
                "text arrives, such as {:?}, and no packet of Ridgetone: another device, or another program on the board",
                self.example
            ),
            false => format!(
                "{bytes} bytes have arrived, and no packet of Ridgetone: another baud rate than 921600, another device, or no common ground"
            ),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_and_noise_are_named() {
        let what = |bytes: &[u8]| {
            let mut strangers = Strangers::default();
            (0..2000 / bytes.len()).for_each(|_| strangers.take(bytes));
            strangers.what()
        };
        assert!(what(b"x:0.12,y:0.3\r\n").is_some_and(|text| text.contains("\"x:0.12,y:0.3\"")));
        let noise: Vec<u8> = (0..=255).collect();
        assert!(what(&noise).is_some_and(|text| text.contains("921600")));
        let mut few = Strangers::default();
        few.take(b"garbage");
        assert_eq!(few.what(), None);
    }
}
