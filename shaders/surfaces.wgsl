// The model's triangles in the view's camera: the common parts of all passes of the renderer, and the passes
// that need nothing else: nearness (the depth buffer) and faces (1 + the face that owns a pixel). Passes whose names begin
// with `peeled` draw what is behind the layers that were drawn before.
// Rust: gpu/renderer/frame.rs (Frame), gpu/renderer/surfaces.rs (Surface, corners), gpu/renderer/tables.rs
// (FaceCells), gpu/renderer/peel.rs (peeling).
//
// Positions are relative to the viewpoint, in world axes; where rays are parallel (frame.parallel), to a reference point near the
// surfaces. A corner is given as the sum of two f32 vectors, so
// that its difference to the viewpoint is exact to f32 wherever the site lies.

struct Frame {
    // Rows of the rotation, world to camera.
    right: vec3f,
    focal_x: f32,
    down: vec3f,
    focal_y: f32,
    forward: vec3f,
    // Depth of the near plane, in world units: nearer than all visible points. Of parallel rays 1 over the range of depths.
    near: f32,
    // Principal point and size, in pixels.
    center: vec2f,
    size: vec2f,
    // The viewpoint, as a sum of two f32, relative to the site's origin.
    eye_high: vec3f,
    // fx * fy of the view.
    density: f32,
    eye_low: vec3f,
    // Weight of a missing octave of resolution, in radians.
    lambda: f32,
    // Side of a cell, in pixels.
    cell_px: u32,
    // 1 + tolerance: the factor by which a face that is drawn later is brought nearer.
    reach: f32,
    // 1: faces are drawn with their relief; 0: they are flat.
    relief: f32,
    // 1: back sides of faces are drawn; 0: they are culled.
    backs: u32,
    // The factor of 1 - agreement in penalties, in radians.
    transient_angle: f32,
    // The darkening of the view by its lens: the largest squared tangent of the angle to the axis, and the coefficients of
    // the logarithm of the light, of the squared tangent and of its square.
    widest: f32,
    falloff: vec2f,
    // The first range of the cells of the surroundings, the number of their columns, 0 where the view shows none, and 1
    // over the distance between cameras from which they see other surroundings.
    surroundings_first: u32,
    surroundings_columns: u32,
    per_surroundings_scale: f32,
    // The index of the dome's first side among the photos.
    dome_first: u32,
    // The first of the factors of groups of light on faces among the candidates, and the number of groups; 0 where all factors
    // are 1.
    light_first: u32,
    light_groups: u32,
    // 1: rays are parallel, along `forward`; focal lengths are pixels per world unit, `density` is their product.
    parallel: u32,
    // Of parallel rays: a depth behind everything.
    far: f32,
    // The factor on light in the common exposure, and 1 where surfaces continue that no photo shows.
    of_common: vec3f,
    continues: u32,
    // The factor that brings the sky that all photos share to that of the photos near the view.
    of_sky: vec3f,
    // The distance of cameras from the viewpoint from which on their surroundings are not shown.
    surroundings_reach: f32,
}

// A planar part of a face: the whole face, or a triangle of a face that is not planar.
struct Surface {
    // The plane's unit normal, and its distance from the site's origin along the normal, as a sum of two f32.
    normal: vec3f,
    distance_high: f32,
    distance_low: f32,
    // Index of the face.
    face: u32,
    // FLAG_BILLBOARD, FLAG_FRONT_IS_BACK, FLAG_BACK_IS_BACK, FLAG_IMPOSTOR, FLAG_SKIRT.
    flags: u32,
    // Of an impostor: its half width, the lowest point of its axis relative to the site's origin, as a sum of two f32, and
    // the unit direction of the axis. 0 for other faces.
    half_width: f32,
    foot_high: vec3f,
    pad0: f32,
    foot_low: vec3f,
    pad1: f32,
    axis: vec3f,
    pad2: f32,
}

// The cells of a face: corner and size (low 16 bits: x, high 16 bits: y), the index of the first range, and whether
// the view leaves the face out.
struct FaceCells {
    corner: u32,
    size: u32,
    first: u32,
    hidden: u32,
}

const FLAG_BILLBOARD: u32 = 1u;
// The side that the normal points towards is a back side, or the other one is (projection/sides.rs).
const FLAG_FRONT_IS_BACK: u32 = 2u;
const FLAG_BACK_IS_BACK: u32 = 4u;
// The surface is the rectangle of an impostor, which faces the viewpoint.
const FLAG_IMPOSTOR: u32 = 8u;
// The surface is a skirt, which is drawn where no face is (projection/skirts.rs).
const FLAG_SKIRT: u32 = 16u;

struct Corner {
    @location(0) high: vec3f,
    @location(1) low: vec3f,
    @location(2) surface: u32,
}

@group(0) @binding(0) var<uniform> frame: Frame;
@group(0) @binding(1) var<storage, read> surfaces: array<Surface>;
@group(0) @binding(2) var<storage, read> face_cells: array<FaceCells>;
// While layers are peeled off: near / z of the layer drawn before, 1 before the first one and 0 where nothing is left.
@group(0) @binding(10) var peeled_depths: texture_depth_2d;

// The distance from the viewpoint to the plane, along its normal: positive where the plane is seen from
// behind.
fn distance_to_plane(surface: Surface) -> f32 {
    return (surface.distance_high - dot(surface.normal, frame.eye_high))
        + (surface.distance_low - dot(surface.normal, frame.eye_low));
}

// True when a plane, `distance` from the viewpoint along its normal, is seen from the side that its normal does not point to.
fn is_seen_from_behind(normal: vec3f, distance: f32) -> bool {
    if frame.parallel != 0u {
        return dot(normal, frame.forward) > 0.0;
    }
    return distance > 0.0;
}

// True when the surface is hidden, or its visible side is a back side and these are culled.
fn is_left_out(surface: Surface) -> bool {
    let side = select(FLAG_FRONT_IS_BACK, FLAG_BACK_IS_BACK, is_seen_from_behind(surface.normal, distance_to_plane(surface)));
    let is_back = frame.backs == 0u && (surface.flags & side) != 0u;
    return is_back || face_cells[surface.face].hidden != 0u;
}

// Clip coordinates; depth is near / z, of parallel rays (far - z) * near, so that it rises towards the camera and is linear over the
// image.
// `reach` brings the surface nearer by the visibility tolerance, `reach_of_skirts` those of skirts: 0 puts them behind all faces.
fn clip_from_corner(corner: Corner, reach: f32, reach_of_skirts: f32) -> vec4f {
    if is_left_out(surfaces[corner.surface]) {
        // All corners are at one point beyond the depth range, so nothing is drawn.
        return vec4f(0.0, 0.0, 2.0, 1.0);
    }
    let p = (corner.high - frame.eye_high) + (corner.low - frame.eye_low);
    let camera = vec3f(dot(frame.right, p), dot(frame.down, p), dot(frame.forward, p));
    let is_skirt = (surfaces[corner.surface].flags & FLAG_SKIRT) != 0u;
    let nearer = select(reach, reach_of_skirts, is_skirt);
    if frame.parallel != 0u {
        let px = vec2f(frame.focal_x, frame.focal_y) * camera.xy + frame.center;
        let at = 2.0 * px / frame.size - 1.0;
        return vec4f(at.x, -at.y, (frame.far - camera.z) * frame.near * nearer, 1.0);
    }
    let x = 2.0 * (frame.focal_x * camera.x + frame.center.x * camera.z) / frame.size.x - camera.z;
    let y = camera.z - 2.0 * (frame.focal_y * camera.y + frame.center.y * camera.z) / frame.size.y;
    return vec4f(x, y, frame.near * nearer, camera.z);
}

// Where the ray through a pixel position begins, relative to the viewpoint: there, or in the plane of the reference point.
fn start_of_ray(px: vec2f) -> vec3f {
    if frame.parallel == 0u {
        return vec3f(0.0);
    }
    let in_plane = (px - frame.center) / vec2f(frame.focal_x, frame.focal_y);
    return frame.right * in_plane.x + frame.down * in_plane.y;
}

// The ray through a pixel position, in world axes, of depth 1.
fn ray_through(px: vec2f) -> vec3f {
    if frame.parallel != 0u {
        return frame.forward;
    }
    let in_camera = (px - frame.center) / vec2f(frame.focal_x, frame.focal_y);
    return frame.right * in_camera.x + frame.down * in_camera.y + frame.forward;
}

@vertex
fn nearness(corner: Corner) -> @invariant @builtin(position) vec4f {
    return clip_from_corner(corner, 1.0, 0.0);
}

@vertex
fn peeled_nearness(corner: Corner) -> @invariant @builtin(position) vec4f {
    return clip_from_corner(corner, 1.0, 1.0);
}

// True when a fragment belongs to the layer drawn before, or to one in front of it. Its depth is `reach` times as large as in
// the depth buffer.
fn is_peeled(position: vec4f, reach: f32) -> bool {
    return position.z * (frame.reach / reach) >= textureLoad(peeled_depths, vec2i(position.xy), 0);
}

@fragment
fn unpeeled(@builtin(position) position: vec4f) {
    if is_peeled(position, 1.0) {
        discard;
    }
}

struct Owner {
    @builtin(position) position: vec4f,
    @location(0) @interpolate(flat) face: u32,
}

@vertex
fn owner(corner: Corner) -> Owner {
    return Owner(clip_from_corner(corner, frame.reach, 0.0), surfaces[corner.surface].face);
}

// As `owner`, but with the index of the surface instead of the face.
@vertex
fn peeled_owner(corner: Corner) -> Owner {
    return Owner(clip_from_corner(corner, frame.reach, frame.reach), corner.surface);
}

@fragment
fn faces(owner: Owner) -> @location(0) u32 {
    return owner.face + 1u;
}

@fragment
fn peeled_surfaces(owner: Owner) -> @location(0) u32 {
    if is_peeled(owner.position, frame.reach) {
        discard;
    }
    return owner.face + 1u;
}
