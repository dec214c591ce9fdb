"""The order of instructions: the ones that much still waits for come first.

A processor looks a few hundred instructions ahead.  In depth-first order the long chains of a mechanism (angles,
pivots, mass matrix) stand one behind the other; listed by how long the way to the results still is, independent chains
overlap. On the CPM that is a fifth of the time of a scalar call.  The order changes no digit.
"""

from __future__ import annotations

import heapq
from dataclasses import replace

import numpy as np

from cutjoint.compile.expressions.operations import Op
from cutjoint.compile.expressions.program import Program

LATENCY = {Op.INPUT: 0, Op.CONST: 0, Op.DIV: 13, Op.SQRT: 18, Op.SIN: 60, Op.COS: 60, Op.ATAN2: 80, Op.ACOS: 80}
"""Cycles until a result can be used, roughly, of any recent processor; 4 where nothing is said."""


LONGEST = 6000
"""Longer programs keep their depth-first order: values would have to wait too long in memory."""


def scheduled(program: Program) -> Program:
    """The same program in list-scheduled order, unless it is long."""
    count = len(program.op)
    if count > LONGEST:
        return program
    ops = [Op(code) for code in program.op.tolist()]
    rows = program.operands.tolist()
    reads = [rows[k][: op.arity] for k, op in enumerate(ops)]
    users: list[list[int]] = [[] for _ in range(count)]
    for k, operands in enumerate(reads):
        for operand in set(operands):
            users[operand].append(k)
    latency = [LATENCY.get(op, 4) for op in ops]
    height = [0] * count
    for k in range(count - 1, -1, -1):
        height[k] = latency[k] + max((height[user] for user in users[k]), default=0)

    missing = [len(set(operands)) for operands in reads]
    ready = [(-height[k], k) for k in range(count) if missing[k] == 0]
    heapq.heapify(ready)
    waiting: list[tuple[int, int]] = []
    order: list[int] = []
    cycle = 0
    while ready or waiting:
        while waiting and waiting[0][0] <= cycle:
            k = heapq.heappop(waiting)[1]
            heapq.heappush(ready, (-height[k], k))
        if not ready:
            cycle = waiting[0][0]
            continue
        k = heapq.heappop(ready)[1]
        order.append(k)
        for user in users[k]:
            missing[user] -= 1
            if missing[user] == 0:
                heapq.heappush(waiting, (cycle + latency[k], user))
        cycle += 1 if latency[k] else 0

    place = np.empty(count + 1, dtype=np.int32)
    place[order] = np.arange(count, dtype=np.int32)
    place[-1] = -1
    operands = program.operands[order]
    is_input = (program.op[order] == Op.INPUT)[:, None]
    moved = np.where(is_input, operands, place[np.where(is_input, -1, operands)])
    return replace(
        program,
        op=program.op[order],
        operands=moved.astype(np.int32),
        values=program.values[order],
        outputs=place[program.outputs],
    )
