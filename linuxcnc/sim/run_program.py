#!/usr/bin/env python3
"""What LinuxCNC takes for its user interface: homes the machine, runs the program of the configuration, changes between modes, and
writes every cycle of the servo thread to a CSV. Ends with 1, and a message on standard error, where LinuxCNC reports an error."""

import csv
import math
import sys
import time

import hal
import linuxcnc

COLUMNS = (
    "x y z coarse_0 coarse_1 coarse_2 joint_0 joint_1 joint_2 force_x force_y force_z on "
    "correction_0 correction_1 correction_2 status clocks_update clocks_motion phase"
).split()
PATIENCE_S = 60.0
JOG_MM, JOG_MM_PER_S = 180.0, 90.0

command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()
configuration = linuxcnc.ini(sys.argv[sys.argv.index("-ini") + 1])


class Samples:
    """Rows of the sampler, written as they come, with a word for what happened meanwhile."""

    def __init__(self, path):
        self.component = hal.component("run_program")
        self.component.ready()
        self.stream = hal.stream(self.component, hal.sampler_base, "ffffffffffffbfffsss")
        self.rows = csv.writer(open(path, "w", newline=""))
        self.rows.writerow(COLUMNS)
        self.phase = "start"

    def take(self):
        while (row := self.stream.read()) is not None:
            self.rows.writerow([*row, self.phase])
        if self.stream.num_overruns:
            sys.exit("run_program: samples were lost")


def wait(samples, done, what):
    """Takes samples until `done`. LinuxCNC's errors and too long a wait end the program."""
    end = time.monotonic() + PATIENCE_S
    while True:
        samples.take()
        message = errors.poll()
        if message:
            sys.exit(f"run_program: LinuxCNC says, while {what}: {message[1]}")
        status.poll()
        if done():
            return
        if time.monotonic() > end:
            sys.exit(f"run_program: no end after {PATIENCE_S} s while {what}")
        time.sleep(0.01)


def mode(samples, teleop):
    """Joint mode, or axes moved by hand."""
    command.teleop_enable(teleop)
    wanted = linuxcnc.TRAJ_MODE_TELEOP if teleop else linuxcnc.TRAJ_MODE_FREE
    wait(samples, lambda: status.motion_mode == wanted, "changing mode")
    pause(samples, 0.2)


def pause(samples, seconds):
    end = time.monotonic() + seconds
    wait(samples, lambda: time.monotonic() > end, "waiting")


def main():
    samples = Samples(configuration.find("SIMULATION", "SAMPLES"))
    wait(samples, lambda: status.joints == 3 and status.task_state == linuxcnc.STATE_ESTOP, "starting")
    command.state(linuxcnc.STATE_ESTOP_RESET)
    wait(samples, lambda: status.task_state == linuxcnc.STATE_ESTOP_RESET, "resetting the emergency stop")
    command.state(linuxcnc.STATE_ON)
    wait(samples, lambda: status.task_state == linuxcnc.STATE_ON, "switching on")
    command.mode(linuxcnc.MODE_MANUAL)
    command.home(-1)
    wait(samples, lambda: all(status.homed[:3]), "homing")

    samples.phase = "program"
    command.mode(linuxcnc.MODE_AUTO)
    command.program_open(configuration.find("SIMULATION", "PROGRAM"))
    command.auto(linuxcnc.AUTO_RUN, 1)
    wait(samples, lambda: status.interp_state != linuxcnc.INTERP_IDLE, "starting the program")
    wait(samples, lambda: status.interp_state == linuxcnc.INTERP_IDLE and status.inpos, "running the program")

    # Forward kinematics in LinuxCNC's own hands: joint mode takes positions from joints, and back.
    command.mode(linuxcnc.MODE_MDI)
    for line in ("M64 P0", "G4 P0.5"):
        command.mdi(line)
        command.wait_complete()
    samples.phase = "modes"
    command.mode(linuxcnc.MODE_MANUAL)
    for teleop in (False, True, False, True):
        mode(samples, teleop)

    # A joint jogged to where the tool is beyond the box, from there to axes, and back.
    if configuration.find("KINS", "KINEMATICS") == "kinetostat_kins":
        samples.phase = "beyond"
        for way in (JOG_MM, -JOG_MM):
            mode(samples, False)
            end = status.joint_position[0] + way
            command.jog(linuxcnc.JOG_INCREMENT, True, 0, math.copysign(JOG_MM_PER_S, way), abs(way))
            wait(samples, lambda: status.inpos and abs(status.joint_position[0] - end) < 1e-3, "jogging a joint")
            mode(samples, True)
    samples.take()


main()
