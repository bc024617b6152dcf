#include "pie/scene/cells.h"
