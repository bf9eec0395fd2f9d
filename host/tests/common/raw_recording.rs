//! A board's recording in which raw frames were sent from the start.

use hal_mock::Sliding;
use ridgetone_finger::Pipeline;
use ridgetone_host::input::Input;
use ridgetone_host::replay;
use ridgetone_proto::settings::Settings;
use ridgetone_proto::telemetry::{Packet, WIRE_MAX, encode};

/// Returns the bytes that a board sends for a scene.
pub fn of(scene: Sliding, settings: Settings) -> Vec<u8> {
    let mut pipeline = Box::new(Pipeline::new(settings));
    pipeline.report_raw(u32::MAX);
    let mut events = vec![pipeline.hello()];
    let input = Input::of(scene).open().expect("a scene");
    replay::conversions(input, &mut |timed| {
        pipeline.push(timed, &mut |event| events.push(event));
        Ok(())
    })
    .expect("a run");
    pipeline.finish(&mut |event| events.push(event));
    let (mut bytes, mut sequence) = (Vec::new(), 0u16);
    for event in events {
        let mut wire = [0; WIRE_MAX];
        let used = encode(&Packet { sequence, event }, &mut wire).expect("it fits");
        sequence = sequence.wrapping_add(1);
        bytes.extend_from_slice(&wire[..used]);
    }
    bytes
}
