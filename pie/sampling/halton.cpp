#include "pie/sampling/halton.h"
