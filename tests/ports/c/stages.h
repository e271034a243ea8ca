/* The stages. Each reads its inputs, computes, and writes its outputs. */

#ifndef STAGES_H
#define STAGES_H

#include "json.h"

void time_of_impact(const struct json *input);      /* S2, pair.c */
void normal_and_weights(const struct json *input);  /* S3, pair.c */
void group_into_zones(const struct json *input);    /* S5, zones.c */
void zone_at_point(const struct json *input);       /* S6, zone.c */
void lagrangian_at_point(const struct json *input); /* S7, zone.c */
void line_search(const struct json *input);         /* S8, search.c */
void update_multipliers(const struct json *input);  /* S9, zone.c */
void first_iterations(const struct json *input);    /* S10, steps.c */
void optimum_of_zone(const struct json *input);     /* S11, optimum.c */

#endif
