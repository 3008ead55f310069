"""The meaning of the columns that many tables share."""

COLUMNS = {
    "joint": "which joint",
    "load": "load cycle, see `studies.space`",
    "nodes": "node pairs",
    "elements": "elements on the contact, along one side in space",
    "corner_size": "element at the corner of the contact / a",
    "friction": "coefficient of friction",
    "question": "what is asked",
    "load_factor": "load factor",
    "load_ratio": "load factor over the shakedown limit",
    "onset": "load factor at the first slip of the bonded contact; 0 if it happens under the mean load alone",
    "guaranteed": "guaranteed limit lambda_1",
    "shakedown": "shakedown limit lambda_2",
    "time": "load corners visited; 0 at the mean load",
    "sigma": "bulk stress",
    "node": "number of the node",
    "x": "position / a",
    "slip": "slip",
    "q": "nodal shear force on the punch",
    "p": "nodal normal force",
    "status": "0 stick, +1 and -1 slip along +x and against it, 2 open: until the next event",
    "seconds": "time of the answer",
    "residual": "largest residual of the answers",
}
"""Columns of many tables -> their meaning.

Columns of the paper's scene have the units of `studies.paper`.
"""
