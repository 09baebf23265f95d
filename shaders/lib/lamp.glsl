// Local lights in view, as frame::Lamps uploads them. Metres relative to the eye.
struct Lamp {
    vec4 position;   // range
    vec4 direction;  // cosine of the outer angle
    vec4 intensity;  // 1 / (cosine of the inner − cosine of the outer angle)
};
layout(std430, binding = 0) restrict readonly buffer Lamps { Lamp lamps[]; };
