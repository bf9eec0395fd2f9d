//! What orders change in a detector, between two frames.

use super::{Detector, Imaging};
use crate::touch::contact::ContactDetector;
use ridgetone_proto::boot::SettingsSource;
use ridgetone_proto::settings::Settings;

impl Detector {
    /// From now on these settings are in force; they must have passed [`Settings::validate`]. A slide that lasts goes on;
    /// its windows are of the new length, and none of them reaches back before it.
    #[inline(never)]
    pub fn change(&mut self, settings: &Settings, source: SettingsSource) {
        (self.settings, self.source) = (*settings, source);
        self.assembler.set_reference(settings.vref_v);
        self.episodes.set_reference(settings.vref_v);
        let rest = &mut self.rest;
        rest.contact.set_rule(settings.slide);
        rest.scheduler.change(settings, rest.contact.sliding().map(|(start, _)| start));
    }

    /// Begins anew, as after power-up, or with `going` not given stops: then nothing is told but `health`, faults and
    /// raw frames. Frames are counted on, and device time goes on.
    #[inline(never)]
    pub fn restart(&mut self, going: bool) {
        self.stopped = !going;
        self.rest.begun = false;
        self.rest.scheduler.drop_due();
        self.rest.contact = ContactDetector::new(self.settings.slide);
        self.imaging = Imaging::new();
        self.choose_way();
    }

    /// The next so many frames are told as they were read.
    pub fn tell_raw(&mut self, frames: u32) {
        self.raw_frames = frames;
        self.choose_way();
    }

    /// Whether the finger is on something, or was until just now.
    pub const fn is_touched(&self) -> bool {
        self.rest.contact.is_touched()
    }

    /// While frames are told raw, or nothing is, all go the long way: the short one knows nothing of that.
    pub(super) const fn choose_way(&mut self) {
        self.assembler.take_the_long_way(self.stopped || self.raw_frames > 0);
    }
}
