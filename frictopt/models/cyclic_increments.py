class CyclicBound: load_factor=0.0
def cyclic_bound(*a): raise NotImplementedError
