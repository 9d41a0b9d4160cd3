# args: --max-steps 10k
@register()
def scene() -> Shape:
    total = 0
    for i in range(10 ** 6):
        for j in range(10 ** 6):
            total += i * j
    return primitive_call('cube', shape_kwargs={'scale': total})
