// From a pixel and its depth to the point, metres relative to the eye. Matches frame::Camera.
uniform vec4 uRight;    // right · tan(half field of view across), near
uniform vec4 uUp;       // up · tan(half field of view), far
uniform vec4 uForward;  // forward, unused
uniform vec2 uPixel;    // 1 / resolution

vec3 viewRay(vec2 fragCoord) {
    vec2 ndc = fragCoord * uPixel * 2.0 - 1.0;
    return uRight.xyz * ndc.x + uUp.xyz * ndc.y + uForward.xyz;
}
float eyeDepth(float depth) { return uRight.w * uUp.w / (depth * (uUp.w - uRight.w) + uRight.w); }
