#include "pie/lights/light_set.h"
