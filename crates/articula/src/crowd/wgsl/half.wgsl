
// Palettes in the form `half`: three rows of four halves.
@group(1) @binding(0) var<storage, read> articula_palettes: array<vec2<u32>>;

fn articula_entry(index: u32) -> ArticulaRows {
    let at = index * 3u;
    return ArticulaRows(
        articula_halves(articula_palettes[at]),
        articula_halves(articula_palettes[at + 1u]),
        articula_halves(articula_palettes[at + 2u]),
    );
}
