// Bounding shadow volume of one instance's box: the vertex index is the corner (see instanced/volume.h).
uniform vec3 uLight;
#include "lib/instanced.glsl"
#ifdef MASKED
#include "lib/survivor.glsl"
layout(std430, binding = 4) restrict readonly buffer Survivors { Survivor survivors[]; };
#endif
uniform mat4 uClipFromRelative;
uniform float uExtrusion;  // metres: behind the whole scene
uniform float uFloor;      // height of the lowest receiver, relative to the eye
uniform int uFirstCaster;
flat out Caster vCaster;

void main() {
#ifdef MASKED
    Survivor survivor = survivors[uFirstCaster + gl_InstanceID];
    Caster c = casters[survivor.caster];
#else
    Caster c = casters[uFirstCaster + gl_InstanceID];
#endif
    vCaster = c;
    // The light in the box's axes; mirrored so that no component is negative.
    vec3 light = toBoxAxes(c, uLight);
    vec3 mirror = vec3(light.x < 0.0 ? -1.0 : 1.0, light.y < 0.0 ? -1.0 : 1.0, light.z < 0.0 ? -1.0 : 1.0);
    int corner = gl_VertexID;
    vec3 side = vec3(corner & 1, (corner >> 1) & 1, (corner >> 2) & 1) * 2.0 - 1.0;
    // An odd number of mirrors turns the triangles inside out, and exchanging two axes turns them back.
    if (mirror.x * mirror.y * mirror.z < 0.0) side = side.yxz;
    vec3 world = c.place.xyz + fromBoxAxes(c, c.box.xyz + c.reach.xyz * side * mirror) / c.place.w;
    // Below the lowest receiver there is nothing to darken: a high sun makes short volumes.
    float top = c.place.z + (c.box.z + c.reach.z) / c.place.w;
    float extrusion = min(uExtrusion, (top - uFloor) / max(-uLight.z, 1e-6));
    float moved = (corner & 8) != 0 ? extrusion : 0.0;
#ifdef MASKED
    moved = clamp(moved, survivor.from / c.place.w, survivor.to / c.place.w);
#endif
    world += uLight * moved;
    gl_Position = uClipFromRelative * vec4(world, 1.0);
}
