/* What the loops of the whole plant share. `records.h` holds the package's own records (plant_t, state_t and so on), which
 * the benchmark writes out. */
#define _GNU_SOURCE /* sincos */
#include <math.h>

#include "records.h"

static inline double limited(double value, double limit)
{
    return value > limit ? limit : value < -limit ? -limit : value;
}

static inline double after_dry_friction(double free_speed, double speed, double sliding, double holding)
{
    const double limit = speed == 0.0 ? holding : sliding;
    return free_speed > limit ? free_speed - sliding : free_speed < -limit ? free_speed + sliding : 0.0;
}
