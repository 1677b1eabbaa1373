const float kPi = 3.14159265359f;
const float kInvPi = 0.31830988618f;
const float kTwoPow32Inv = 2.3283064365e-10f;
