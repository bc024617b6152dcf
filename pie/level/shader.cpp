#include "pie/level/shader.h"
