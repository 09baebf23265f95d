// Where a prototype's vertex stands, metres relative to the eye, world axes.
layout(location = 0) in vec3 aPosition;
layout(location = 3) in vec4 aInstance;   // position relative to the eye, scale
layout(location = 4) in vec2 aCosSinYaw;

vec3 rotateYaw(vec3 p, vec2 cosSin) { return vec3(cosSin.x * p.x - cosSin.y * p.y, cosSin.y * p.x + cosSin.x * p.y, p.z); }
vec3 instancePosition() { return aInstance.xyz + aInstance.w * rotateYaw(aPosition, aCosSinYaw); }
