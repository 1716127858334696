
struct ArticulaDraw {
    character: u32,
    first_matrix: u32,
}

@group(1) @binding(1) var<storage, read> articula_draws: array<ArticulaDraw>;

fn articula_character(instance: u32) -> u32 {
    return articula_draws[instance].character;
}

// Mean of four entries of the palette of a draw, by their weights. `instance` counts all draws of the
// frame. For more influences, add the results of each four.
fn articula_skin(instance: u32, entries: vec4<u32>, weights: vec4<f32>) -> ArticulaRows {
    let first = articula_draws[instance].first_matrix;
    var sum = ArticulaRows(vec4<f32>(0.0), vec4<f32>(0.0), vec4<f32>(0.0));
    for (var i = 0u; i < 4u; i++) {
        if weights[i] != 0.0 {
            sum = articula_add(sum, articula_entry(first + entries[i]), weights[i]);
        }
    }
    return sum;
}
