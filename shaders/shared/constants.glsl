const float kPi = 3.14159265359f;
const float kInvPi = 0.31830988618f;
// Texels that the environment's list samples with a density above this (1/sr, share of all light) belong to a sun.
const float kSunDensity = 100.0f;
