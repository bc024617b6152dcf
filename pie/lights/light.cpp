#include "pie/lights/light.h"
