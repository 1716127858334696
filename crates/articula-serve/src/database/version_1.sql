-- Items, whole or as far as they are made, by the BLAKE3 of their manifest, which is an object.
CREATE TABLE items (
    manifest TEXT PRIMARY KEY CHECK (length(manifest) = 64),
    bytes INTEGER NOT NULL,
    sent_bytes INTEGER NOT NULL
) STRICT, WITHOUT ROWID;

-- What is to be packaged, is, and was: one source in one way. Times are seconds since 1970.
CREATE TABLE jobs (
    job TEXT PRIMARY KEY CHECK (length(job) = 64),
    state TEXT NOT NULL CHECK (state IN ('waiting', 'packaging', 'ready', 'failed')),
    stages INTEGER NOT NULL DEFAULT 0,
    attempts INTEGER NOT NULL DEFAULT 0,
    item TEXT REFERENCES items,
    why TEXT,
    queued INTEGER NOT NULL DEFAULT (unixepoch()),
    started INTEGER,
    ended INTEGER,
    CHECK (state != 'ready' OR item IS NOT NULL),
    CHECK ((state = 'failed') = (why IS NOT NULL))
) STRICT, WITHOUT ROWID;
CREATE INDEX jobs_item ON jobs (item);

-- The characters of the folder. `stamp` tells an unchanged file without reading it.
CREATE TABLE characters (
    name TEXT PRIMARY KEY,
    file TEXT NOT NULL,
    stamp TEXT,
    source TEXT NOT NULL CHECK (length(source) = 64),
    job TEXT NOT NULL REFERENCES jobs
) STRICT, WITHOUT ROWID;
CREATE INDEX characters_job ON characters (job);

-- What queries made of items: `object` is a GLB or the manifest of a cut.
CREATE TABLE variants (
    variant TEXT PRIMARY KEY CHECK (length(variant) = 64),
    item TEXT NOT NULL REFERENCES items ON DELETE CASCADE,
    form TEXT NOT NULL CHECK (form IN ('cut', 'glb')),
    query TEXT,
    object TEXT NOT NULL CHECK (length(object) = 64),
    made INTEGER NOT NULL DEFAULT (unixepoch())
) STRICT, WITHOUT ROWID;
CREATE INDEX variants_item ON variants (item);

-- Devices that were benchmarked, by the BLAKE3 of their description, and the last runs of each.
CREATE TABLE devices (
    device TEXT PRIMARY KEY CHECK (length(device) = 64),
    description TEXT NOT NULL
) STRICT, WITHOUT ROWID;
CREATE TABLE device_runs (
    device TEXT NOT NULL REFERENCES devices ON DELETE CASCADE,
    run INTEGER NOT NULL,
    report TEXT NOT NULL,
    PRIMARY KEY (device, run)
) STRICT, WITHOUT ROWID;
