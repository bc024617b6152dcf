#include "pie/photons/tracer.h"
