#include "render/plan.h"
