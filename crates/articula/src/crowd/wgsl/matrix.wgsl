
// Palettes in the form `matrix`: three rows of four floats.
@group(1) @binding(0) var<storage, read> articula_palettes: array<vec4<f32>>;

fn articula_entry(index: u32) -> ArticulaRows {
    let at = index * 3u;
    return ArticulaRows(
        articula_palettes[at],
        articula_palettes[at + 1u],
        articula_palettes[at + 2u],
    );
}
