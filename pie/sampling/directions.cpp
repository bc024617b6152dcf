#include "pie/sampling/directions.h"
