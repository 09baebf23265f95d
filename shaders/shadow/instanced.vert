// Bounding shadow volume of one instance's box, made from the vertex index (see instanced/volume.h).
layout(location = 3) in vec4 aInstance;   // position relative to the eye, scale
layout(location = 4) in vec2 aCosSinYaw;
layout(location = 5) in vec2 aRotation;   // first map, weight of the second
layout(std430, binding = 0) readonly buffer Corners { uint corners[72]; };
uniform mat4 uClipFromRelative;
uniform vec3 uLight;
uniform vec3 uBoxCentre, uBoxHalf;  // prototype space
uniform float uExtrusion;           // metres: behind the whole scene
uniform float uFloor;               // height of the lowest receiver, relative to the eye
flat out vec4 vInstance;
flat out vec2 vCosSinYaw;
flat out vec2 vRotation;

void main() {
    vInstance = aInstance;
    vCosSinYaw = aCosSinYaw;
    vRotation = aRotation;
    // The light in the box's axes; mirrored so that no component is negative.
    vec3 light = vec3(aCosSinYaw.x * uLight.x + aCosSinYaw.y * uLight.y, aCosSinYaw.x * uLight.y - aCosSinYaw.y * uLight.x, uLight.z);
    vec3 mirror = vec3(light.x < 0.0 ? -1.0 : 1.0, light.y < 0.0 ? -1.0 : 1.0, light.z < 0.0 ? -1.0 : 1.0);
    // An odd number of mirrors turns the triangles inside out: swap two corners of each.
    int index = gl_VertexID;
    if (mirror.x * mirror.y * mirror.z < 0.0) index += index % 3 == 1 ? 1 : index % 3 == 2 ? -1 : 0;
    uint corner = corners[index];
    vec3 side = vec3(corner & 1u, (corner >> 1) & 1u, (corner >> 2) & 1u) * 2.0 - 1.0;
    vec3 p = uBoxCentre + uBoxHalf * side * mirror;
    vec3 world = aInstance.xyz + aInstance.w * vec3(aCosSinYaw.x * p.x - aCosSinYaw.y * p.y, aCosSinYaw.y * p.x + aCosSinYaw.x * p.y, p.z);
    // Below the lowest receiver there is nothing to darken: a high sun makes short volumes.
    float top = aInstance.z + aInstance.w * (uBoxCentre.z + uBoxHalf.z);
    float extrusion = min(uExtrusion, (top - uFloor) / max(-uLight.z, 1e-6));
    if ((corner & 8u) != 0u) world += uLight * extrusion;
    gl_Position = uClipFromRelative * vec4(world, 1.0);
}
