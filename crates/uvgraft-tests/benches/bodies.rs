//! Benchmarks of body models at SMPL-X's size: 10,475 vertices, 486 pose features, 55 joints.

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use uvgraft_avatar::body::{BodyKind, BodyModel};
use uvgraft_avatar::rig::Pose;
use uvgraft_tests::bodies;

const FRAMES: u32 = 64;

fn bodies(criterion: &mut Criterion) {
    let kind = BodyKind::SmplX;
    let arrays = bodies::synthetic_model(kind);
    let mut group = criterion.benchmark_group("body");
    group.sample_size(10);
    group.bench_function("model from arrays", |bencher| {
        bencher.iter(|| BodyModel::from_arrays(&arrays).expect("a sound model"));
    });
    group.finish();

    let model = BodyModel::from_arrays(&arrays).expect("a sound model");
    let shape = bodies::shape(1, 10, 10);
    let shaped = model.shaped(&shape).expect("a sound shape");
    let poses: Vec<Pose> = (0..FRAMES).map(|seed| bodies::pose(kind, seed).to_pose()).collect();
    // Hands, jaw and eyes at rest, as in body-only motions.
    let body_only: Vec<Pose> = poses.iter().cloned().map(resting_hands).collect();

    let mut group = criterion.benchmark_group("body");
    group.bench_function("shape, 20 coefficients", |bencher| {
        bencher.iter(|| model.shaped(&shape).expect("a sound shape"));
    });
    let whole = bodies::shape(2, 300, 100);
    group.bench_function("shape, 400 coefficients", |bencher| {
        bencher.iter(|| model.shaped(&whole).expect("a sound shape"));
    });
    for (name, poses) in [("all joints", &poses), ("22 joints", &body_only)] {
        // Cycle through the poses, so that no frame finds its own values in the cache.
        let mut turn = poses.iter().cycle();
        group.throughput(Throughput::Elements(1));
        group.bench_function(format!("one frame, {name}"), |bencher| {
            bencher.iter(|| turn.next().map(|pose| shaped.posed(pose).expect("a sound pose")));
        });
        group.throughput(Throughput::Elements(u64::from(FRAMES)));
        group.bench_function(format!("{FRAMES} frames, {name}"), |bencher| {
            bencher.iter(|| shaped.posed_frames(poses).expect("sound poses"));
        });
    }
    group.finish();
}

fn resting_hands(mut pose: Pose) -> Pose {
    pose.rotations[22..].fill([0.0, 0.0, 0.0, 1.0]);
    pose
}

criterion_group!(benches, bodies);
criterion_main!(benches);
