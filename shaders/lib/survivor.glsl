// A caster whose shadow volume can meet a visible receiver, and where along the light, in its own scale.
struct Survivor {
    uint caster;
    float from, to;
};
