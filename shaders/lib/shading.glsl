// Shading of the 2004 course notes (Stamminger): in shadow the ambient term stays, the diffuse term is
// dimmed, the specular term goes.
uniform vec3 uLight;      // unit, direction in which the light travels
uniform float uDaylight;  // of the sky: 1 by day, near 0 at night
const float kShadowDim = 0.12;

vec3 shade(vec3 albedo, float specular, vec3 normal, vec3 toEye, float visibility) {
    const vec3 sunColour = vec3(2.6, 2.4, 2.05), skyColour = vec3(0.36, 0.46, 0.62), groundColour = vec3(0.17, 0.15, 0.12);
    vec3 ambient = mix(groundColour, skyColour, normal.z * 0.5 + 0.5);
    float up = uLight.z < 0.0 ? 1.0 : 0.0;  // no dimmed sun from below the horizon
    float diffuse = up * max(dot(normal, -uLight), 0.0) * mix(kShadowDim, 1.0, visibility);
    float h = max(dot(normal, normalize(toEye - uLight)), 0.0);
    h *= h; h *= h; h *= h; h *= h;
    vec3 colour = albedo * (ambient * uDaylight + sunColour * diffuse) + up * specular * h * visibility;
    return colour / (1.0 + 0.25 * colour);
}
vec3 sky(vec3 ray) {
    float t = clamp(ray.z * 2.2, 0.0, 1.0);
    return mix(vec3(0.72, 0.8, 0.88), vec3(0.22, 0.42, 0.72), t) * uDaylight;
}
