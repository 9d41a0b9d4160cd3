"""Names of the builtins by topic, written by ``make tables``."""

NAMES: dict[str, list[str]] = {
    "entities.registry": 'retrieve no-entities bound? call-embeddings apply-entity-function make-entity primitive parts primitives map-parts frames embedding embedding-text embedding-handle embedding-attributes entity-word entity-embedding entity-children primitive? blocks? compute-shape-min compute-shape-max compute-shape-center compute-shape-sizes'.split(),
    "entities.poses": 'translate rotate scale reflect look-at pose'.split(),
    "solids.registry": 'difference intersection solid-union hull minkowski rounded shell offset-solid cut-plane split profile-section profile-silhouette extrude text lathe sweep loft heightfield mesh surface-poses volume surface-area centroid inertia'.split(),
    "profiles.registry": 'circle rectangle polygon regular-polygon star arc spline svg-path text-outline profile-union profile-difference profile-intersection profile-hull profile-minkowski offset-profile transform-profile profile-area'.split(),
    "paths.registry": 'polyline bezier catmull-rom helix resample-path path-length point-at tangent-at frame-at'.split(),
    "numbers.registry": '+ - * / // % modulo expt square = < > <= >= abs floor ceiling truncate inexact exact->inexact sqrt exp log10 log2 sin cos tan asin acos sinh cosh tanh deg to-degrees sign exact round log atan hypot clamp lerp smoothstep quotient remainder floor/ truncate/ exact-integer-sqrt bitwise-and bitwise-or bitwise-xor arithmetic-shift gcd lcm zero? positive? negative? nan? finite? infinite? even? odd? number->string string->number'.split(),
    "predicates.registry": 'not boolean? none? number? integer? exact? inexact? string? symbol? keyword? table? set? record? procedure? entity? embedding? stream? mutable? array? vector? matrix? pair? null? list? eq? boolean=? eqv? equal?'.split(),
    "lists.registry": 'cons car cdr caar cadr cdar cddr caaar caadr cadar caddr cdaar cdadr cddar cdddr caaaar caaadr caadar caaddr cadaar cadadr caddar cadddr cdaaar cdaadr cdadar cdaddr cddaar cddadr cdddar cddddr list values list* make-list iota range append list-copy list-head list-tail list-ref member memq memv assoc assq assv'.split(),
    "sequences.registry": 'length string-length vector-length empty? first second third last rest take drop reverse zip enumerate repeat flatten contains? index-of count delete-duplicates delete ->list string->list vector->list mutable mutable-list mutable-array ref vector-ref string-ref slice substring sort min-of max-of'.split(),
    "control.calling": 'map for-each append-map filter-map filter remove partition find list-index any every fold fold-left fold-right reduce apply'.split(),
    "mutation.registry": 'set-ref! update! push! pop! insert! extend! add! remove! remove-at! splice! remove-key! clear! sort! reverse!'.split(),
    "mutation.tables": 'table list->table table-keys table-values table-items table-merge has-key? keywords set list->set set-union set-intersection set-difference subset?'.split(),
    "strings.registry": 'string string-append string-join list->string string-split string-upcase string-downcase string-trim string-trim-left string-trim-right string-contains? string-prefix? string-suffix? string-index string-replace string-pad string-pad-right ord chr symbol->string string->symbol string=? string<? string>? string<=? string>=? string-ci=? format'.split(),
    "arrays.registry": 'array vector list->vector zeros ones full eye linspace arange array-shape transpose reshape stack-arrays concatenate expand-dims sum product mean min max argmin argmax cumsum clip array-map interp where x-of y-of z-of @ dot cross norm normalize distance inverse determinant solve identity-pose'.split(),
    "random.registry": 'random-state set-random-state! set-seed! py-set-seed! random-stream default-rng py-random-stream random uniform normal randint rand randn choice shuffle shuffle! permutation py-random py-uniform py-gauss py-randint py-randrange py-choice py-choices py-sample py-shuffle py-shuffle! noise fbm'.split(),
    "control.registry": 'error raise gensym assertion-failed declare-that error? error-message error-code error-place error-is? print void identity'.split(),
    "colors.registry": 'color rgb hsv texture'.split(),
    "cameras.registry": 'camera light environment render-settings'.split(),
    "python.registry": 'py-truthy? py-bool-or py-bool-and py-+ py-* py-% py-== py-< py-in py-iter py-ref py-str'.split(),
}
