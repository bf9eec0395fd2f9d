//! Events sent by the board, each in a numbered packet. [`crate::framing`] describes how a packet
//! is transmitted.

mod decoder;
mod estimate;
mod event;
mod events;
mod image;
mod packet;
mod starts;
mod texture;

pub use crate::framing::{TooLong, WIRE_MAX};
pub use decoder::{Decoder, PacketDecoder};
pub use estimate::{
    Channel, Direction, Estimate, Movement, OtherTone, Span, Status, Travel, TravelStatus,
};
pub use event::*;
pub use events::{Events, Headline};
pub use image::{Hold, Image, Pressed};
pub use packet::{PROTOCOL, Packet, encode, longest_packet};
pub use starts::Starts;
pub use texture::{Overtones, Texture};
