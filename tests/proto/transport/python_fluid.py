"""A fluid written in Python from docs/PROTOCOL.md alone; python_participant_test.cpp runs it. Usage: ENDPOINT CASE_HASH [KEYS]."""

import sys

from tern.participant.channel import Participant, RunEnded
from tern.participant.schema import wire

account = wire.Account(energy=[1.5, 2.5], gauge=[0, 2.5], undefined=[True, False])
try:
    with Participant(sys.argv[1], wire.FLUID, start_deadline_s=10, progress_deadline_s=10,
                     keys=sys.argv[3] if len(sys.argv) > 3 else None) as channel:
        channel.handshake(wire.Hello(case_hash=sys.argv[2], dimension=2, version="python", account=account))
        while channel.receive("begin_window", "finish").WhichOneof("body") == "begin_window":
            channel.receive("surface")
            channel.send(interface_particles=wire.InterfaceParticles(id=[4], position=[0, 1], velocity=[2, 3], mass=[1], volume=[1],
                                                                     divergence=[0]))
            message = channel.receive("interface_condition")
            while message.WhichOneof("body") == "interface_condition":
                channel.send(interface_pressure=wire.InterfacePressure(pressure=[sum(message.interface_condition.force)], velocity=[0, 0]))
                message = channel.receive("interface_condition", "interface_force")
            channel.send(window_done=wire.WindowDone(proposed_step_s=1e-3, limit="none", account=account))
        channel.send(finished=wire.Finished(account=account))
except RunEnded as end:
    print(end, file=sys.stderr)
    sys.exit(end.exit_code)
