"""The look of all pictures. This room knows no result.

`style.py` has colours, axes, legends, arrows and the names of units; `draw.py` draws a result by
the picture that is registered for its class. The pictures themselves stand in the `pictures.py` of
each room. matplotlib comes with the extra `figures`.
"""
