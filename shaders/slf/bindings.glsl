// Texture units of surface light fields, for shaders and for C++ (render/slf/buffers.cpp): none that others have, because all bakes stay bound.
const int kUnitLightFieldSlots = 72;
const int kUnitLightFieldSides = 73;
const int kUnitLightFieldClusters = 74;
const int kUnitLightFieldWeights = 75;
const int kUnitLightFieldLumispheres = 76;
const int kUnitLightFieldCells = 77;
const int kUnitLightFieldRadiance = 78;
const int kUnitLightFieldErrors = 79;
