// Pass scan: converts counts to offsets in three steps: sums of runs, offsets of runs, offsets of pixels.
// Element i of `places` becomes the offset at which the entries of pixel i end; pass fill counts down from
// there.
// Rust: gpu/scan.rs.

// Pixels that one invocation adds up.
const RUN: u32 = 64u;
// Invocations of the one workgroup that adds up the runs.
const WIDE: u32 = 256u;

@group(1) @binding(0) var<storage, read_write> places: array<u32>;
@group(1) @binding(1) var<storage, read_write> runs: array<u32>;

@compute @workgroup_size(64)
fn sum_runs(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&runs) {
        return;
    }
    let end = min((id.x + 1u) * RUN, arrayLength(&places));
    var sum = 0u;
    for (var i = id.x * RUN; i < end; i++) {
        sum += places[i];
    }
    runs[id.x] = sum;
}

var<workgroup> sums: array<u32, WIDE>;

@compute @workgroup_size(WIDE)
fn place_runs(@builtin(local_invocation_index) self_: u32) {
    let share = (arrayLength(&runs) + WIDE - 1u) / WIDE;
    let begin = min(self_ * share, arrayLength(&runs));
    let end = min(begin + share, arrayLength(&runs));
    var sum = 0u;
    for (var i = begin; i < end; i++) {
        sum += runs[i];
    }
    sums[self_] = sum;
    workgroupBarrier();
    // With 256 sums, adding up the preceding ones costs less than a tree and its barriers.
    var before = 0u;
    for (var i = 0u; i < self_; i++) {
        before += sums[i];
    }
    for (var i = begin; i < end; i++) {
        let own = runs[i];
        runs[i] = before;
        before += own;
    }
}

@compute @workgroup_size(64)
fn place_pixels(@builtin(global_invocation_id) id: vec3<u32>) {
    if id.x >= arrayLength(&runs) {
        return;
    }
    let end = min((id.x + 1u) * RUN, arrayLength(&places));
    var place = runs[id.x];
    for (var i = id.x * RUN; i < end; i++) {
        place += places[i];
        places[i] = place;
    }
}
