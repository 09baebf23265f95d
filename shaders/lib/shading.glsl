// Shading of the 2004 course notes (Stamminger): in shadow the ambient term stays, the diffuse term is
// dimmed, the specular term goes.
#ifndef SUNS
#define SUNS 1
#endif
uniform vec4 uSuns[SUNS]; // unit direction in which the light travels, strength
uniform float uDaylight;  // of the sky: 1 by day, near 0 at night
const float kShadowDim = 0.12;

vec3 shade(vec3 albedo, float specular, vec3 normal, vec3 toEye, float visibility[SUNS]) {
    const vec3 sunColour = vec3(2.6, 2.4, 2.05), skyColour = vec3(0.36, 0.46, 0.62), groundColour = vec3(0.17, 0.15, 0.12);
    vec3 ambient = mix(groundColour, skyColour, normal.z * 0.5 + 0.5);
    float diffuse = 0.0, highlight = 0.0, suns = 0.0;
    for (int i = 0; i < SUNS; ++i) {
        vec3 light = uSuns[i].xyz;
        float up = light.z < 0.0 ? uSuns[i].w : 0.0;  // no dimmed sun from below the horizon
        suns += up;
        diffuse += up * max(dot(normal, -light), 0.0) * mix(kShadowDim, 1.0, visibility[i]);
        float h = max(dot(normal, normalize(toEye - light)), 0.0);
        h *= h; h *= h; h *= h; h *= h;
        highlight += up * h * visibility[i];
    }
    vec3 colour = albedo * (ambient * uDaylight + sunColour * diffuse) + specular * highlight;
    // Exposed so that a white wall square to every sun is just white: 0 stays 0, and what is dark keeps its brightness.
    vec3 brightest = skyColour * uDaylight + sunColour * suns;
    float white = max(brightest.r, max(brightest.g, brightest.b));
    return colour / (1.0 + max(0.25, 1.0 - 1.0 / white) * colour);
}
vec3 sky(vec3 ray) {
    float t = clamp(ray.z * 2.2, 0.0, 1.0);
    return mix(vec3(0.72, 0.8, 0.88), vec3(0.22, 0.42, 0.72), t) * uDaylight;
}
