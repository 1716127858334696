//! Random sequences of changes of a catalogue, which is opened again in between, beside a plain one in memory.

use super::characters::{self, CharacterRow};
use super::devices::{self, DeviceRows};
use super::jobs::{self, ItemRow, Job, JobState};
use super::variants::{self, Variant};
use super::{Database, Opened};
use proptest::prelude::*;
use std::collections::BTreeMap;

/// Runs of a device and devices that are kept.
const MOST: (usize, usize) = (3, 2);

#[derive(Debug, Clone)]
enum Change {
    /// A character, by number, of a source, by number: its job waits.
    Put(u8, u8),
    Remove(u8),
    Begin(u8),
    /// A job has an item so far, or in the end.
    Stage(u8, u8),
    Finish(u8, u8),
    Fail(u8),
    /// A query of an item makes an object.
    Make(u8, u8, u8),
    Run(u8, u8),
    /// All that no character has is removed, whatever its age.
    Sweep,
    /// The server ends, by itself or killed, and another one begins.
    Reopen,
}

fn change() -> impl Strategy<Value = Change> {
    let few = 0..4u8;
    prop_oneof![
        4 => (few.clone(), few.clone()).prop_map(|(a, b)| Change::Put(a, b)),
        1 => few.clone().prop_map(Change::Remove),
        3 => few.clone().prop_map(Change::Begin),
        3 => (few.clone(), few.clone()).prop_map(|(a, b)| Change::Stage(a, b)),
        3 => (few.clone(), few.clone()).prop_map(|(a, b)| Change::Finish(a, b)),
        1 => few.clone().prop_map(Change::Fail),
        2 => (few.clone(), few.clone(), few.clone()).prop_map(|(a, b, c)| Change::Make(a, b, c)),
        3 => (few.clone(), few).prop_map(|(a, b)| Change::Run(a, b)),
        1 => Just(Change::Sweep),
        1 => Just(Change::Reopen),
    ]
}

/// A name of 64 digits.
fn hash(kind: &str, number: u8) -> String {
    let text = format!("{kind}{number}");
    format!("{text:0>64}")
}

/// A catalogue as plain maps.
#[derive(Debug, Default, PartialEq)]
struct Model {
    characters: BTreeMap<String, CharacterRow>,
    jobs: BTreeMap<String, Job>,
    variants: BTreeMap<String, Variant>,
    devices: BTreeMap<String, Vec<String>>,
}

impl Model {
    fn set(&mut self, job: String, state: JobState, item: Option<String>) {
        let why = (state == JobState::Failed).then(|| "it is broken".to_owned());
        self.jobs.insert(job, Job { state, item, why });
    }

    fn change(&mut self, change: &Change) {
        use JobState::{Failed, Packaging, Ready, Waiting};
        match *change {
            Change::Put(name, source) => {
                let row = row(name, source);
                self.set(row.job.clone(), Waiting, None);
                self.characters.insert(row.name.clone(), row);
            }
            Change::Remove(name) => {
                self.characters.remove(&row(name, 0).name);
            }
            Change::Begin(job) => self.set(hash("b", job), Packaging, None),
            Change::Stage(job, item) => {
                // A job that waits or ended has no stages.
                let job = self.jobs.get_mut(&hash("b", job));
                if let Some(job) = job.filter(|job| job.state == Packaging) {
                    job.item = Some(hash("c", item));
                }
            }
            Change::Finish(job, item) => self.set(hash("b", job), Ready, Some(hash("c", item))),
            Change::Fail(job) => self.set(hash("b", job), Failed, None),
            Change::Make(query, item, object) => {
                let variant = variant(query, item, object);
                self.variants.insert(variant.variant.clone(), variant);
            }
            Change::Run(device, report) => {
                let device = hash("f", device);
                if self.devices.contains_key(&device) || self.devices.len() < MOST.1 {
                    let runs = self.devices.entry(device).or_default();
                    runs.push(report.to_string());
                    let surplus = runs.len().saturating_sub(MOST.0);
                    runs.drain(..surplus);
                }
            }
            Change::Sweep => {
                let named = |job: &String| self.characters.values().any(|c| c.job == *job);
                self.jobs.retain(|job, _| named(job));
                let items: Vec<_> = self.jobs.values().filter_map(|j| j.item.clone()).collect();
                self.variants.retain(|_, of| items.contains(&of.item));
            }
            Change::Reopen => {
                for job in self.jobs.values_mut().filter(|job| job.state == Packaging) {
                    (job.state, job.item) = (Waiting, None);
                }
            }
        }
    }

    fn read(database: &Database) -> Self {
        let read = database.read(|db| {
            let characters = characters::all(db)?.into_iter();
            let variants = variants::all(db)?.into_iter();
            let devices = devices::all(db)?.into_iter();
            let mut names = db.prepare("SELECT job FROM jobs")?;
            let names = names.query_map([], |row| row.get::<_, String>(0))?;
            let job = |name: rusqlite::Result<String>| {
                let name = name?;
                let job = jobs::get(db, &name)?.unwrap();
                Ok((name, job))
            };
            Ok(Self {
                characters: characters.map(|of| (of.name.clone(), of)).collect(),
                jobs: names.map(job).collect::<rusqlite::Result<_>>()?,
                variants: variants.map(|of| (of.variant.clone(), of)).collect(),
                devices: devices
                    .map(|DeviceRows { device, reports }| (device, reports))
                    .collect(),
            })
        });
        read.unwrap()
    }
}

fn row(name: u8, source: u8) -> CharacterRow {
    CharacterRow {
        name: format!("n{name}"),
        file: format!("n{name}.glb"),
        stamp: (source > 1).then(|| format!("{source} bytes")),
        source: hash("a", source),
        job: hash("b", source),
    }
}

fn variant(query: u8, item: u8, object: u8) -> Variant {
    Variant {
        variant: hash("d", query),
        item: hash("c", item),
        form: ["cut", "glb"][usize::from(query % 2)].to_owned(),
        query: (query > 1).then(|| format!("loa={query}")),
        object: hash("e", object),
    }
}

fn write(database: &Database, change: &Change) {
    let job = |number: u8| hash("b", number);
    let written = database.write(|db| match *change {
        Change::Put(name, source) => {
            let row = row(name, source);
            jobs::wait(db, &row.job)?;
            characters::put(db, &row)
        }
        Change::Remove(name) => characters::remove(db, &row(name, 0).name),
        Change::Begin(number) => jobs::begin(db, &job(number)),
        Change::Stage(number, item) => jobs::stage(db, &job(number), &made(&hash("c", item))),
        Change::Finish(number, item) => jobs::finish(db, &job(number), &made(&hash("c", item))),
        Change::Fail(number) => jobs::fail(db, &job(number), "it is broken"),
        Change::Make(query, item, object) => {
            let variant = variant(query, item, object);
            variants::put(db, &variant, &made(&variant.item))
        }
        Change::Run(device, report) => {
            let device = hash("f", device);
            devices::put(db, (&device, "{}"), &report.to_string(), MOST).map(drop)
        }
        Change::Sweep => jobs::sweep(db, 0).map(drop),
        Change::Reopen => jobs::take_up(db).map(drop),
    });
    written.unwrap();
}

fn made(manifest: &str) -> ItemRow<'_> {
    ItemRow {
        manifest,
        bytes: 10,
        sent_bytes: 5,
    }
}

fn opened(place: &std::path::Path) -> Database {
    let Opened { database, note } = Database::open(place, true).unwrap();
    assert_eq!(note, None);
    database
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 48, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn a_catalogue_holds_what_a_plain_one_does(changes in prop::collection::vec(change(), 1..60)) {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("catalogue.sqlite3");
        let mut database = opened(&place);
        let mut model = Model::default();
        for change in &changes {
            if matches!(change, Change::Reopen) {
                drop(database);
                database = opened(&place);
            }
            write(&database, change);
            model.change(change);
            prop_assert_eq!(&Model::read(&database), &model);
        }
        drop(database);
        // Another one that only reads sees the same.
        let read = Database::open_read_only(&place).unwrap();
        prop_assert_eq!(&Model::read(&read), &model);
    }
}
