//! How much of the server the clients of one address hold.

use std::collections::HashMap;
use std::net::{IpAddr, Ipv6Addr};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Connections and sessions that are open, by address.
#[derive(Debug)]
pub(crate) struct Addresses {
    /// Most of one address; all without.
    most: Option<usize>,
    open: Mutex<HashMap<IpAddr, usize>>,
}

/// A connection, or the session that it became, until the last clone is dropped.
#[derive(Debug)]
pub(crate) struct AddressPlace {
    addresses: Arc<Addresses>,
    address: IpAddr,
}

impl Addresses {
    pub(crate) fn new(most: Option<usize>) -> Arc<Self> {
        let open = Mutex::default();
        Arc::new(Self { most, open })
    }

    /// Takes a place; `None` if the address has all of its own.
    pub(crate) fn open(self: &Arc<Self>, address: IpAddr) -> Option<Arc<AddressPlace>> {
        let address = subscriber(address);
        let mut open = self.lock();
        let count = open.get(&address).copied().unwrap_or(0);
        if self.most.is_some_and(|most| count >= most) {
            return None;
        }
        open.insert(address, count + 1);
        Some(Arc::new(AddressPlace {
            addresses: Arc::clone(self),
            address,
        }))
    }

    fn lock(&self) -> MutexGuard<'_, HashMap<IpAddr, usize>> {
        self.open.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Drop for AddressPlace {
    fn drop(&mut self) {
        let mut open = self.addresses.lock();
        match open.get_mut(&self.address) {
            Some(count) if *count > 1 => *count -= 1,
            _ => drop(open.remove(&self.address)),
        }
    }
}

/// What counts as one client: an address of version 4, and of version 6 the 64 bits that one network has (RFC 4291).
fn subscriber(address: IpAddr) -> IpAddr {
    match address.to_canonical() {
        IpAddr::V6(v6) => IpAddr::V6(Ipv6Addr::from_bits(v6.to_bits() & !u128::from(u64::MAX))),
        v4 => v4,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_address_holds_its_places_and_no_more_and_others_have_theirs() {
        let addresses = Addresses::new(Some(2));
        let of = |text: &str| addresses.open(text.parse().unwrap());
        let held = [of("192.0.2.1").unwrap(), of("::ffff:192.0.2.1").unwrap()];
        assert!(of("192.0.2.1").is_none());
        assert!(of("192.0.2.2").is_some());
        let session = Arc::clone(&held[0]);
        drop(held);
        // The connection has ended; the session that it became has not.
        let one = of("192.0.2.1").unwrap();
        assert!(of("192.0.2.1").is_none());
        drop((one, session));
        assert!(addresses.lock().is_empty());
    }

    #[test]
    fn a_network_of_version_6_is_one_client() {
        let addresses = Addresses::new(Some(1));
        let of = |text: &str| addresses.open(text.parse().unwrap());
        let _held = of("2001:db8:0:1::1").unwrap();
        assert!(of("2001:db8:0:1:ffff::2").is_none());
        assert!(of("2001:db8:0:2::1").is_some());
    }

    #[test]
    fn without_a_limit_all_places_are_given() {
        let addresses = Addresses::new(None);
        let held: Vec<_> = (0..1000)
            .map(|_| addresses.open(IpAddr::from([127, 0, 0, 1])))
            .collect();
        assert!(held.iter().all(Option::is_some));
    }
}
