
struct ArticulaImpostorDraw {
    character: u32,
    pose: u32,
}

// Size and place of every picture, and the numbers of columns of the atlas, directions and rows.
struct ArticulaImpostorCells {
    corner: vec2<f32>,
    size: vec2<f32>,
    metres_per_px: f32,
    columns: u32,
    views: u32,
    rows: u32,
}

struct ArticulaImpostorVertex {
    // In the world.
    place: vec3<f32>,
    // In pixels of the atlas, from its top left.
    texel: vec2<f32>,
}

@group(1) @binding(1) var<storage, read> articula_impostors: array<ArticulaImpostorDraw>;
@group(1) @binding(3) var<uniform> articula_cells: ArticulaImpostorCells;
// Centre of each pose, x, y, z and 0.
@group(1) @binding(4) var<storage, read> articula_centres: array<vec4<f32>>;
// Of each row: least pitch of the eyes, pitch, lean, number of yaws.
@group(1) @binding(5) var<storage, read> articula_view_rows: array<vec4<f32>>;

fn articula_character(instance: u32) -> u32 {
    return articula_impostors[instance].character;
}

// Corner 0 to 3 of an impostor, in the order of a triangle strip: lower left, lower right, upper left,
// upper right. `eye` is in the world.
fn articula_impostor(instance: u32, corner: u32, eye: vec3<f32>) -> ArticulaImpostorVertex {
    let draw = articula_impostors[instance];
    let world = articula_world(draw.character);
    let centre = articula_centres[draw.pose].xyz;
    // Towards the eye in model space, of any length: a rotation and one scale for all axes.
    let away = eye - articula_point(world, centre);
    let toward = away.x * world.x.xyz + away.y * world.y.xyz + away.z * world.z.xyz;
    let pitch = atan2(toward.y, length(toward.xz));
    var row = articula_view_rows[0];
    var first = 0u;
    for (var i = 1u; i < articula_cells.rows; i++) {
        let next = articula_view_rows[i];
        if next.x > pitch {
            break;
        }
        first += u32(row.w);
        row = next;
    }
    let turns = atan2(toward.x, toward.z) / 6.2831855;
    let yaw = u32(round((turns - floor(turns)) * row.w)) % u32(row.w);
    let a = 6.2831855 * f32(yaw) / row.w;
    let right = vec3<f32>(cos(a), 0.0, -sin(a));
    let up = vec3<f32>(-sin(a) * sin(row.y), cos(row.y), -cos(a) * sin(row.y));
    let to_eye = vec3<f32>(sin(a) * cos(row.y), sin(row.y), cos(a) * cos(row.y));
    let side = vec2<f32>(f32(corner & 1u), f32(corner >> 1u));
    let at = articula_cells.corner + side * articula_cells.size * articula_cells.metres_per_px;
    let place = centre + right * at.x + (up + to_eye * row.z) * at.y;
    let picture = draw.pose * articula_cells.views + first + yaw;
    let column = f32(picture % articula_cells.columns);
    let line = f32(picture / articula_cells.columns);
    let texel = (vec2<f32>(column, line) + vec2<f32>(side.x, 1.0 - side.y)) * articula_cells.size;
    return ArticulaImpostorVertex(articula_point(world, place), texel);
}
