component kinetostat_probe "Calls the kinematics each cycle as LinuxCNC's motion module does";
description """A range check of a move that is not made yet (ahead), the position commanded now, and the forward kinematics of what that gave.""";
pin in float position-#[3];
pin in float ahead-#[3];
pin out float joint-#[3];
pin out float back-#[3];
pin out s32 answer "0, or the first of the three calls that failed";
function _;
license "MIT OR Apache-2.0";
;;
#include "kinematics.h"

FUNCTION(_) {
    EmcPose world = {.tran = {position(0), position(1), position(2)}};
    EmcPose next = {.tran = {ahead(0), ahead(1), ahead(2)}};
    double joints[3], unused[3];
    answer = kinematicsInverse(&next, unused, 0, 0) ? 1 : kinematicsInverse(&world, joints, 0, 0) ? 2 : 0;
    if (answer) return;
    /* From the position of the cycle before, as motion does. */
    world = (EmcPose){.tran = {back(0), back(1), back(2)}};
    if (kinematicsForward(joints, &world, 0, 0)) answer = 3;
    for (int i = 0; i < 3; i++) joint(i) = joints[i];
    back(0) = world.tran.x;
    back(1) = world.tran.y;
    back(2) = world.tran.z;
}
