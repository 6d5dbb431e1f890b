/* Inverse kinematics in C: the best posture for a pose, the feasible arm angles, and the best posture for a task.

   srs-ik inspect iiwa14 --packed iiwa14.limb
   cc solve.c $(python -m srs_ik.kernels.native) -o solve && ./solve iiwa14.limb
*/
#include <srs_ik.h>
#include <stdio.h>
#include <stdlib.h>

static double family[4][SRS_IK_LIMB_SIZE];

int main(int count, char **words) {
    if (count != 2 || srs_ik_read_limb(words[1], family) != 0) {
        fprintf(stderr, "usage: solve FILE, which srs-ik inspect ROBOT --packed FILE writes\n");
        return 2;
    }
    const double q[1][7] = {{0.3, 0.7, -0.4, -1.1, 0.5, 0.8, -0.2}};
    double pose[1][4][4], row[SRS_IK_ANSWER_ROW];
    srs_ik_kinematics_forward_range(*family, *q, 0, 1, **pose, 1);

    int64_t verdict;
    if (srs_ik_pose_solve(*family, **pose, -1, *q, true, true, row, &verdict) || verdict) return 1;
    printf("status %g:", row[SRS_IK_ANSWER_ROW_STATUS]);
    for (int i = 0; i < 7; i++) printf(" %.12f", row[SRS_IK_ANSWER_ROW_Q + i]);

    static double intervals[SRS_IK_ANSWER_MOST_INTERVALS][3];
    int64_t found;
    if (srs_ik_pose_intervals(*family, **pose, true, *intervals, &found) || found < 0) return 1;
    printf("\n%lld intervals\n", (long long)found);
    for (int64_t i = 0; i < found; i++)
        printf("branch %g: %.12f to %.12f\n", intervals[i][0], intervals[i][1], intervals[i][2]);

    /* Of all postures the one that is best for a force along z and a motion along x. */
    double params[SRS_IK_OBJECTIVES_PARAMS] = {0.0, 0.0, 1.0, 1.0, 0.0, 0.0}, out[SRS_IK_SEARCH_OUT];
    params[SRS_IK_OBJECTIVES_RESPECT] = 1.0;
    if (srs_ik_optimum_optimise(*family, **pose, SRS_IK_OBJECTIVES_RATIO, -1, 0.0, 3e-9, params, true, row, out, &found) ||
        found != SRS_IK_SEARCH_FOUND)
        return 1;
    printf("least %.12f at arm angle %.6f\n", out[SRS_IK_SEARCH_OUT_VALUE], row[SRS_IK_ANSWER_ROW_ARM_ANGLE]);

    enum { POSES = 1000 };
    static double poses[POSES][4][4], rows[POSES][SRS_IK_ANSWER_ROW];
    static int8_t verdicts[POSES];
    for (int i = 0; i < POSES; i++)
        for (int k = 0; k < 16; k++) poses[i][k / 4][k % 4] = pose[0][k / 4][k % 4];
    if (srs_ik_pose_solve_range(*family, **poses, 0, POSES, -1, *q, true, *rows, verdicts, POSES, 1)) return 1;
    int solved = 0;
    for (int i = 0; i < POSES; i++) solved += verdicts[i] == 0 && rows[i][SRS_IK_ANSWER_ROW_STATUS] == 0.0;
    printf("%d of %d solved, for %s\n", solved, POSES, srs_ik_target());
    return 0;
}
