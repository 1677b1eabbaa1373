const float kPi = 3.14159265359f;
const float kInvPi = 0.31830988618f;
const float kTwoPow32Inv = 2.3283064365e-10f;
// What an environment's list draws with more than this density (1/sr), its share of all light, is a sun.
const float kSunDensity = 100.0f;
