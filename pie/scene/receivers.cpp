#include "pie/scene/receivers.h"
