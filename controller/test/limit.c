/* The speed limit as a filter: reads lines of free_mm, age_ms, fastest_mm_s, latency_ms, deceleration_mm_s2 and
 * oldest_ms; writes a line with the limit for each. */
#include <stdio.h>

#include "../stairscan.h"

int main(void) {
    unsigned long with[6];
    while (scanf("%lu %lu %lu %lu %lu %lu", &with[0], &with[1], &with[2], &with[3], &with[4], &with[5]) == 6) {
        stairscan_ground_t ground;
        stairscan_chair_t chair;
        ground.free_mm = (uint32_t)with[0];
        ground.age_ms = (uint32_t)with[1];
        ground.fastest_mm_s = (uint32_t)with[2];
        chair.latency_ms = (uint32_t)with[3];
        chair.deceleration_mm_s2 = (uint32_t)with[4];
        chair.oldest_ms = (uint32_t)with[5];
        printf("%lu\n", (unsigned long)stairscan_max_speed(&ground, &chair));
    }
    return 0;
}
