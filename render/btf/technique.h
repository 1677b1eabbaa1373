#pragma once

#include "render/technique/technique.h"

namespace maquette {

/// How BTFs are read: settings that all modes share.
Technique btf_technique();

}  // namespace maquette
