//! Renewal of all certificates of an authority that end soon, for a timer that runs it every day.

use jiff::{SignedDuration, Timestamp};

use super::{Authority, DAY, EARLIER, Error, Order, Role, Written, issued, revocation::of_file};
use crate::Certificate;

impl Authority {
    /// Issues all certificates again, with new keys, whose files in the folder end within this time, and
    /// that are not revoked: for the same hosts and the same number of days, or up to the end of the
    /// authority. Older certificates of the same name are left alone.
    ///
    /// # Errors
    /// If files cannot be read or written; those renewed before stay renewed.
    pub fn renew(&self, within: SignedDuration) -> Result<Vec<Written>, Error> {
        let now = Timestamp::now();
        let mut renewed = Vec::new();
        for one in issued(&self.folder)? {
            let Certificate { common_name, serial, hosts, not_before, not_after, .. } = one.facts;
            let file = self.folder.join(format!("{common_name}.pem"));
            let is_current = file.exists() && of_file(&file)?.serial == serial;
            if one.revoked.is_some() || !is_current || not_after.duration_since(now) > within {
                continue;
            }
            let days = |length: SignedDuration| length.as_hours() / DAY.as_hours();
            let half_a_day = DAY / 2;
            let length = days(not_after.duration_since(not_before) - EARLIER + half_a_day).max(1);
            let left = days(self.certificate.not_after.duration_since(now));
            let hosts = hosts.into_iter().filter(|host| *host != common_name).collect();
            // The role decides only about hosts that are not given.
            let role = Role::Worker;
            let days = length.min(left);
            renewed.push(self.issue(&Order {
                name: common_name,
                hosts,
                role,
                days,
                renew: true,
            })?);
        }
        Ok(renewed)
    }

    /// End of the authority's own certificate, which nothing renews: everyone who trusts it has it.
    pub fn end(&self) -> Timestamp {
        self.certificate.not_after
    }
}
