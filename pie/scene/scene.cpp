#include "pie/scene/scene.h"
