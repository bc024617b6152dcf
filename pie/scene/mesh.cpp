#include "pie/scene/mesh.h"
