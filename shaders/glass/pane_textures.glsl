/// What panes and blended surfaces read of their own textures (render/glass/panes.cpp).
const int kPaneBaseColor = 0, kPaneTransmission = 1, kPaneThickness = 2, kPaneEmission = 3, kPaneNormal = 4, kPaneMetallic = 5,
          kPaneSpecular = 6, kPaneSpecularColor = 7, kPaneTextures = 8;
uniform int u_textures[kPaneTextures];  // -1: none
