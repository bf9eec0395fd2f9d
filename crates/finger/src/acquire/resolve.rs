//! Majority decision between two or three reads of a conversion.

use crate::converter::{Sample, Tag};

/// Result of the reads. NEW is set in every conversion that is returned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Resolved {
    /// A new conversion on which both reads agree.
    Found(Sample),
    /// A conversion on which two of three reads agree, or in which only NEW is wrong.
    Mended(Sample),
    /// The conversion after the expected one, which ended between the first and the second read.
    Later(Sample),
    /// No two reads agree.
    Garbled,
    /// All bits are ones, or all are zeros.
    Dead,
    /// The latest conversion again.
    Repeated,
    /// The latest conversion again, with a bit error in one read of it.
    RepeatedGarbled,
}

/// Two reads of a conversion; `None` if a read failed.
pub type Reads = [Option<Sample>; 2];

/// Resolves two reads of which at least one is not the expected conversion, with a `third` if they
/// differ. `latest` is the previous conversion, `next` has NEW and the id of the expected one.
pub fn resolve(
    latest: Option<Sample>,
    next: u8,
    [first, again]: Reads,
    third: impl FnOnce() -> Option<Sample>,
) -> Resolved {
    if let Some(first) = first
        && again.is_some_and(|again| is_same(first, again))
    {
        let is_read_again = again.is_some_and(|again| !again.tag.is_new());
        return match first.tag.is_new() {
            _ if is_dead(first) => Resolved::Dead,
            // Only the id is unexpected, or the new code happens to equal the old one.
            true if is_read_again => Resolved::Found(first),
            _ if latest.is_some_and(|latest| is_same(latest, first)) => Resolved::Repeated,
            // A bit error in NEW.
            _ if as_new(first).tag.0 & Tag::NEW_AND_ID == next => Resolved::Mended(as_new(first)),
            _ => Resolved::Garbled,
        };
    }
    let third = third();
    let agree =
        |one: Option<Sample>| one.filter(|one| third.is_some_and(|third| is_same(*one, third)));
    let Some(agreed) = agree(first).or(agree(again)) else {
        return Resolved::Garbled;
    };
    let is_first = agree(first).is_some();
    if is_dead(agreed) {
        Resolved::Dead
    } else if !agreed.tag.is_new() && latest.is_some_and(|latest| is_same(latest, agreed)) {
        Resolved::RepeatedGarbled
    } else if !is_first && agreed.tag.is_new() && agreed.tag.0 & Tag::NEW_AND_ID != next {
        // NEW is set in the second read, so the first read was of an earlier conversion.
        Resolved::Later(agreed)
    } else {
        Resolved::Mended(as_new(agreed))
    }
}

/// True if two reads have the same data, apart from NEW.
fn is_same(one: Sample, other: Sample) -> bool {
    one.code == other.code && (one.tag.0 ^ other.tag.0) & !Tag::NEW == 0
}

/// True if all bits but NEW are ones, or all are zeros: id 1Fh is unused, and 00h is not in the
/// scan.
fn is_dead(read: Sample) -> bool {
    matches!((read.tag.0 & !Tag::NEW, read.code), (0x7f, -1) | (0, 0))
}

fn as_new(read: Sample) -> Sample {
    Sample {
        tag: Tag(read.tag.0 | Tag::NEW),
        ..read
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use Resolved::*;

    fn read(status: u8, code: i32) -> Option<Sample> {
        Some(Sample {
            tag: Tag(status),
            code,
        })
    }

    /// Resolves up to three reads when AIN1 (id 9) is expected after AIN0 (id 8).
    fn resolved(reads: [(u8, i32); 3]) -> Resolved {
        let [first, again, third] = reads.map(|(status, code)| read(status, code));
        resolve(read(0x88, 7), 0x89, [first, again], || third)
    }

    const NONE: (u8, i32) = (0x55, 0x55);

    #[test]
    fn two_of_three_reads_decide() {
        let good = read(0x89, 5).unwrap();
        assert_eq!(resolved([(0x89, 5), (0x09, 4), (0x09, 5)]), Mended(good));
        assert_eq!(resolved([(0x89, 4), (0x09, 5), (0x09, 5)]), Mended(good));
        assert_eq!(resolved([(0x8b, 5), (0x09, 5), (0x09, 5)]), Mended(good));
        // The first read fails, and NEW is set in the second.
        assert_eq!(resolved([(0x33, 5), (0x89, 5), (0x09, 5)]), Mended(good));
        assert_eq!(resolved([(0x89, 4), (0x09, 5), (0x09, 6)]), Garbled);
        assert_eq!(resolve(None, 0x88, [None, None], || None), Garbled);
        assert_eq!(
            resolve(None, 0x88, [None, read(0x08, 1)], || read(0x08, 1)),
            Mended(read(0x88, 1).unwrap())
        );
    }

    #[test]
    fn a_bit_error_in_new_is_mended() {
        let good = read(0x89, 5).unwrap();
        assert_eq!(resolved([(0x09, 5), (0x09, 5), NONE]), Mended(good));
        assert_eq!(resolved([(0x89, 5), (0x89, 5), NONE]), Mended(good));
        // Not the next id of the scan, so it could be anything.
        assert_eq!(resolved([(0x0a, 5), (0x0a, 5), NONE]), Garbled);
    }

    #[test]
    fn the_latest_again_is_no_conversion() {
        assert_eq!(resolved([(0x08, 7), (0x08, 7), NONE]), Repeated);
        assert_eq!(resolved([(0x88, 7), (0x88, 7), NONE]), Repeated);
        assert_eq!(resolved([(0x08, 6), (0x08, 7), (0x08, 7)]), RepeatedGarbled);
        // A channel may have the same code a whole scan later.
        assert_eq!(
            resolved([(0x88, 7), (0x08, 7), NONE]),
            Found(read(0x88, 7).unwrap())
        );
    }

    #[test]
    fn the_next_conversion_between_two_reads_is_taken_once() {
        assert_eq!(
            resolved([(0x89, 5), (0x8a, 6), (0x0a, 6)]),
            Later(read(0x8a, 6).unwrap())
        );
    }

    #[test]
    fn a_dead_bus_is_no_conversion() {
        for (status, code) in [(0xff, -1), (0, 0)] {
            assert_eq!(resolved([(status, code), (status, code), NONE]), Dead);
            assert_eq!(resolved([(0x89, 5), (status, code), (status, code)]), Dead);
        }
    }
}
