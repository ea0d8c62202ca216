// An objective as the kernels have it: its terms, and what they are about. Springs that a strain is
// measured of join two nodes and have a rest length.

#define CHAMFER 0
#define TRACK 1
#define ACCELERATION 2
#define STRAIN 3
#define ABOVE 4
#define WITHIN 5
#define CLEARANCE 6
#define FORCE 7
#define ORDER 8
#define WINDING 9
#define COVERAGE 10
#define BY_CONTROLS 0
#define BY_ONE_CONTROL 1
#define BY_GRASP 2
#define BY_GROUND 3
#define BY_COLLIDER 4
#define ALL_NODES 1
#define SMOOTH_L1 0
#define DISTANCE 1
#define SQUARED_DISTANCE 2
#define NODES 0
#define SKIN 1

struct Term {
    u32 kind, frame;
    u32 count;   // targets, nodes of a region, or points of a list
    u32 first;   // first of them
    u32 loss;    // of a region: ALL_NODES, or 0 for those counted; of a force: what exerts it
    u32 of;      // what points near targets, of a track or of a list are: NODES or SKIN
    // Limit of a strain or force, offset of a half space, margin of a collider, gap of an order, wanted
    // turns, reach of a coverage.
    float beta;
    float weight;
    // Number of the collider, or of what exerts the force; of a term at the skin, row of its frame in
    // `point_bars`.
    u32 part;
    // Normal of a half space, corners of a box, direction of an order, or point and direction of a line.
    float low[3], high[3];
};

// A part of a term that a block scores: PIECE targets whose nearest points it seeks, all of any other
// term.
struct Piece {
    u32 term;
    u32 first;  // of its targets
};

struct ObjectiveArgs {
    const float* states;      // [frames + 1][6][N]
    const Term* terms;        // ordered by frame
    const u32* frame_terms;   // [frames + 2]: first term of each frame
    const Piece* pieces;      // in the order of the terms
    const float* targets;     // [targets][3]
    const u32* target_points; // of tracks, regions and lists: nodes or points of the skin
    u32* nearest;             // [targets] of this instance
    double* values;           // [pieces] of this instance
    float* seeds;             // [frames + 1][3][N], or null
    const u32* springs;       // [E][2]
    const float* params;      // as in `params.cu`
    const u32* spring_starts; // [N + 1]: first of each node's in `node_springs`; null without strains
    const u32* node_springs;  // springs between two nodes, ascending for each node
    u32 node_count, surface_count, frame_count, term_count, piece_count;
    u32 cut_every;
    u32 spring_count;         // E
    u32 strained_count;       // springs that a strain is measured of
    u32 control_count;        // C
    u32 skin_frame_count;
    WorldArgs world;
    float* force_bars;        // as `WorldArgs::force_bars`, of all frames; may be null
    SkinArgs skin;            // empty without terms at the skin
    const u32* skin_frames;   // frames with terms at the skin, ascending
    float* point_bars;        // [frames with terms at the skin][3][M]: d loss / d skin, or null
};

DEVICE Positions positions(const ObjectiveArgs& m, u32 frame) {
    return {m.states + (u64)frame * 6 * m.node_count, m.node_count};
}

DEVICE float3 position(const ObjectiveArgs& m, u32 frame, u32 node) {
    return node_at(positions(m, frame), node);
}

// Position of one of the points that a term is about.
DEVICE float3 point_at(const ObjectiveArgs& m, const Term& t, const Positions& p, u32 point) {
    return t.of == SKIN ? skin_at(m.skin, p, point) : node_at(p, point);
}

// True for a term about the nearest points of targets.
DEVICE bool seeks_nearest(const Term& t) { return t.kind == CHAMFER || t.kind == COVERAGE; }
