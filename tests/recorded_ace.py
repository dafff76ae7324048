"""Stands in for the program `ace`: speaks its protocol from recorded answers, and misbehaves.

Started as `ace -V` it tells its version; with a grammar it reads a sentence a line and answers as
ACE 0.9.34 does with --tsdb-stdout. Its grammar file holds JSON: sentence -> list of MRS, or
one of the words "die", "hang" and "garbage".
"""

import json
import os
import sys
import time


def say(line):
    """Write a line at once."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def answer(found):
    """Write what ACE writes for one sentence."""
    if found == "die":
        os._exit(1)
    if found == "hang":
        time.sleep(600)
    if found == "garbage":
        say('(:results . (((:result-id . 0) (:mrs . "[ what is this"))))\n\n')
        return
    rows = "".join(
        f'((:result-id . {i}) (:derivation . "") (:mrs . {json.dumps(mrs)}))'
        for i, mrs in enumerate(found)
    )
    say(f"NOTE: {len(found)} readings, added 83 / 20 edges to chart")
    say(f"(:ninputs . 3) (:readings . {len(found)}) (:results . ({rows}))\n\n")


def main():
    """Run as ACE would be run."""
    if "-V" in sys.argv:
        say("ACE version 0.9.34\ncompiled at 12:00:00 on Jan 1 2024")
        return
    with open(sys.argv[sys.argv.index("-g") + 1], encoding="utf-8") as file:  # noqa: PTH123
        answers = json.load(file)
    say('NOTE: tsdb run: (:application . "answer") (:grammar . "ERG (2025)")')
    for line in sys.stdin:
        answer(answers.get(line.strip(), []))


main()
