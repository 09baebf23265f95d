// A sample counts where the receiver mask is set (Mattausch et al. 2011, "Efficient Online Visibility for Shadow Maps",
// listing 1.2). Writes nothing.
#ifdef MASKED
layout(binding = 0) uniform sampler2D uMask;
uniform vec2 uPixel;  // 1 / viewport
#endif

void main() {
#ifdef MASKED
    if (textureLod(uMask, gl_FragCoord.xy * uPixel, 0.0).r < 0.5) discard;
#endif
}
