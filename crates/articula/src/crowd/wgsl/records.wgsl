
struct ArticulaRecord {
    before: u32,
    after: u32,
    blend: f32,
    character: u32,
}

// The palettes are the cached ones.
@group(1) @binding(1) var<storage, read> articula_records: array<ArticulaRecord>;

fn articula_character(instance: u32) -> u32 {
    return articula_records[instance].character;
}

// Mean of four entries of the palette that a record blends, by their weights. `instance` counts all
// records of the frame. For more influences, add the results of each four.
fn articula_skin(instance: u32, entries: vec4<u32>, weights: vec4<f32>) -> ArticulaRows {
    let record = articula_records[instance];
    var sum = ArticulaRows(vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0));
    for (var i = 0u; i < 4u; i++) {
        if weights[i] != 0.0 {
            let before = articula_entry(record.before + entries[i]);
            let after = articula_entry(record.after + entries[i]);
            sum = articula_add(sum, articula_mix(before, after, record.blend), weights[i]);
        }
    }
    return sum;
}
