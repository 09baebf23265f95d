// What a cell of visibility/receiver_pyramid.h holds: the stamp of the frame that has filled it, over 20 bits of reference depth in
// [0, 1], rounded up. So what older frames have left is less than any key of this one; it says nothing.
const uint kDepthBits = 20u, kMostDepth = (1u << kDepthBits) - 1u;
uniform int uStamp;
uint receiverKey(float z) { return uint(uStamp) << kDepthBits | uint(ceil(clamp(z, 0.0, 1.0) * float(kMostDepth))); }
bool isReceiver(uint key) { return key >> kDepthBits == uint(uStamp); }
float depthOfKey(uint key) { return float(key & kMostDepth) / float(kMostDepth); }
