//! Selecting mesh levels in a frame does not allocate.

use articula_core::{Cluster, Clusters};

#[test]
fn choosing_ranges_allocates_nothing() {
    let regions = 3;
    let lives = (0..5u16).flat_map(|finest| (finest..5).map(move |coarsest| (finest, coarsest)));
    let lives = lives.flat_map(|life| (0..regions).map(move |region| (life, region)));
    let clusters = lives
        .zip(0..)
        .map(|(((finest_level, coarsest_level), region), i)| Cluster {
            finest_level,
            coarsest_level,
            region,
            triangles: 7 * i..7 * (i + 1),
        });
    let mesh = Clusters::new(vec![36, 25, 16, 9, 4], clusters.collect()).unwrap();
    let most = (0..5).map(|l| mesh.ranges(l).count()).max().unwrap();
    let mut buffer = vec![0..0; most * usize::from(regions)];
    let mut drawn = 0;
    let counted = allocation_counter::measure(|| {
        for frame in 0..100u16 {
            let levels = [frame % 5, frame / 5 % 5, frame / 25 % 5];
            for (slot, range) in buffer.iter_mut().zip(mesh.ranges_of(&levels).unwrap()) {
                drawn += range.end - range.start;
                *slot = range;
            }
            drawn += mesh.triangles(usize::from(levels[0])) + mesh.vertices_of(&levels);
        }
    });
    assert_eq!(counted.count_total, 0);
    assert!(drawn > 0);
}
