// Enters and leaves of shadow volumes behind the scene, to be added up.
layout(location = 0) out float oCount;

void main() { oCount = gl_FrontFacing ? -1.0 : 1.0; }
