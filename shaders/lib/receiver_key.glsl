// A reference depth in [0, 1] as an unsigned integer of the same order; 0: none. Of visibility/receiver_pyramid.h.
uint receiverKey(float z) { return floatBitsToUint(clamp(z, 0.0, 1.0)) + 1u; }
float depthOfKey(uint key) { return uintBitsToFloat(key - 1u); }
